#include "server/storage/recording_store.h"
