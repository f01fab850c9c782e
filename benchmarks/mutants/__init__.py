"""Does the test run notice a mistake? Random mutants of the program, each against the tests that cover it."""
