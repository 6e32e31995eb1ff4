"""The whole replication: all its experiments run, and its pages written from what came out."""
