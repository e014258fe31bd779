#pragma once

#include "core/types/result.h"
#include "server/net/http.h"

// Refusals that a connection gives itself, for any route.
namespace faultlab::server {

/// Too many requests wait: those of all callers for a pool thread; those of this caller for a
/// thread or for another server.
HttpResponse PoolFullProblem();
HttpResponse CallerFullProblem();
/// Too many bodies of this caller have arrived only partly.
HttpResponse SlowBodiesProblem();
/// Too many bytes of all connections wait.
HttpResponse BytesFullProblem();
/// Another server does not answer, or too many requests wait for it; `error` states which and what
/// to do.
HttpResponse PeerProblem(const core::Error& error);
/// A handler threw.
HttpResponse InternalProblem();

}  // namespace faultlab::server
