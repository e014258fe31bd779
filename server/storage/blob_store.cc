#include "server/storage/blob_store.h"
