"""Times gluevo's networks beside those of inference engines; see ../compare_engines."""
