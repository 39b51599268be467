"""Many runs: planned, made several at a time, and kept as digests."""
