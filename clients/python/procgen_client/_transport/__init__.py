"""The step stream and its carriers: gRPC, pipes and shared memory; messages and encodings."""
