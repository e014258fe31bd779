#pragma once

#include <memory>
#include <string>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/net/http_server.h"
#include "server/run/run_manager.h"
#include "server/storage/recording_store.h"
#include "server/stream/stream_hub.h"

namespace faultlab::server {

/// A complete server in one object: database, rigs, runs, live stream, API, web page.
class Application {
 public:
  /// Opens the database, marks what a crash cut off, builds the rigs, starts to listen.
  /// @param clock  must outlive it
  static core::Result<std::unique_ptr<Application>> Open(const Config& config,
                                                         const Clock& clock = kSystemClock);
  ~Application();  ///< Stop()
  Application(const Application&) = delete;
  Application& operator=(const Application&) = delete;

  /// Requests in progress are answered, runs stop with safe rigs and complete recordings.
  void Stop();

  std::string address() const;  ///< "127.0.0.1:40123"
  int port() const;
  const Router& router() const;  ///< the routes that are served
  RunManager& runs();
  RecordingStore& store();
  StreamHub& hub();

 private:
  class Impl;
  explicit Application(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace faultlab::server
