#include "core/plant/plant.h"
