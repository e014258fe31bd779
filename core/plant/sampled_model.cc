#include "core/plant/sampled_model.h"
