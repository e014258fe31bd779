#include "server/storage/chunk_codec.h"
