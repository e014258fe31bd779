#include "core/plant/model_fit.h"
