#include "core/signals/excitation.h"
