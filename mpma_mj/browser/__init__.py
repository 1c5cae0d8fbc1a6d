"""Page on which an agent dances live."""
