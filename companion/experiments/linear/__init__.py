"""The paper's simulation (section VI): a network trained on one linear system steers another."""
