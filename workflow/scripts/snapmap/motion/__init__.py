"""How a cell moves: one in full, all of them in brief."""
