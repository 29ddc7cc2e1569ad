"""How fast the program is: `python -m benchmarks` measures and prints."""
