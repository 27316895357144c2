// Catch2's main, shared by the test programs of all floors.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
