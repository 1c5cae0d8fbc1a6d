"""The page on which an agent dances live."""
