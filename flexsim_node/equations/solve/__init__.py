"""Block elimination along the chain: factors of M + c K, and solving with them."""
