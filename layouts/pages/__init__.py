"""The pages, one file each: its ids, its layout, its callbacks."""
