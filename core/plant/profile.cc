#include "core/plant/profile.h"
