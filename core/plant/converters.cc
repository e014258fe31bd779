#include "core/plant/converters.h"
