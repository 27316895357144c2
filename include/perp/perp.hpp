// Everything a program that uses perp includes. Floor by floor, each built on those above it.
#pragma once

#include "perp/version.hpp"

#include "perp/core/errors.hpp"
#include "perp/core/pose.hpp"
#include "perp/core/types.hpp"
