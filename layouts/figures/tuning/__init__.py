"""What studies have come to: the score over one parameter, over two gains, and of a search."""
