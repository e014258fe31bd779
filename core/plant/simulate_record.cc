#include "core/plant/simulate_record.h"
