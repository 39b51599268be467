"""What a scenario may say: typed sections, checks across them, and what follows from them."""
