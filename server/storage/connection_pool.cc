#include "server/storage/connection_pool.h"
