#pragma once

#include "core/types/result.h"
#include "server/net/http.h"

// What a connection itself refuses a request with, whatever its route.
namespace faultlab::server {

/// Too many requests wait: of everybody for a pool thread; of this caller for one, or for another
/// server.
HttpResponse PoolFullProblem();
HttpResponse CallerFullProblem();
/// Too many bodies of this caller are half here.
HttpResponse SlowBodiesProblem();
/// Too many bytes of all connections wait.
HttpResponse BytesFullProblem();
/// Another server does not answer, or too many wait for it; `error` says which and what to do.
HttpResponse PeerProblem(const core::Error& error);
/// A handler threw.
HttpResponse InternalProblem();

}  // namespace faultlab::server
