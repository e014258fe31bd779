#include "core/signals/prbs.h"
