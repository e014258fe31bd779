#include "server/auth/authorization.h"
