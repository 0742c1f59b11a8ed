"""Which shot comes next, what shots say of thresholds that scatter, and how many show a demand."""
