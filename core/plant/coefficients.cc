#include "core/plant/coefficients.h"
