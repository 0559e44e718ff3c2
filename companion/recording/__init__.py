"""One record schema for data sets and flight logs, and its files."""
