"""What is shaken: quantities with their units, a beam, its shape as made, and mass and spring."""
