// Nothing: the unit that carries the headers precompiled for all test programs (main.cpp needs Catch2 afresh).
