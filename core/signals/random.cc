#include "core/signals/random.h"
