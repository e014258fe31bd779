#include "core/plant/propagator.h"
