"""What is done with a flight once it is there: its path, its compression, and the cells that it covers."""
