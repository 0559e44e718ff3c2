"""Features, inverse network, online Gaussian process, reference correction: arrays in, arrays out."""
