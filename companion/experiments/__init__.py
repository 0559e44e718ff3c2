"""The paper's simulation and flights, benchmarks, tables, plots."""
