// The rigid motion that lays measured points onto where they should be.
#pragma once

#include "worker/numerics/rigid_fit.hpp"
