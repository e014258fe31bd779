#include "core/plant/fault_schedule.h"
