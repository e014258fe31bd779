#include "server/storage/database_error.h"
