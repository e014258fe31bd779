#include "server/run/recorder.h"

#include <algorithm>
#include <utility>

#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::milliseconds kNextTry{250};

}  // namespace

Recorder::Recorder(RecordingStore& store,
                   std::string folder,
                   std::function<core::Status()> room,
                   std::function<void(std::string_view)> log)
    : store_(store),
      folder_(std::move(folder)),
      room_(std::move(room)),
      log_(std::move(log)),
      thread_([this] { Loop(); }) {}

Recorder::~Recorder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool Recorder::Append(const std::string& run,
                      std::vector<core::Sample> samples,
                      WhenFull when_full) {
  return samples.empty() || Enqueue(run, {.samples = std::move(samples)}, when_full);
}

bool Recorder::Append(const std::string& run,
                      std::vector<RecordedEvent> events,
                      WhenFull when_full) {
  return events.empty() || Enqueue(run, {.events = std::move(events)}, when_full);
}

bool Recorder::Enqueue(const std::string& run, Part part, WhenFull when_full) {
  std::unique_lock lock(mutex_);
  Book& book = books_[run];
  part.events_before = book.events;
  for (;;) {
    if (!book.failure.empty()) return false;
    if (book.backlog || (away_ && book.queued == 0)) {
      if (PutAside(run, book, part)) break;
    }
    if (!book.backlog && book.queued < kQueuedMax) {
      ++book.queued;
      book.events += static_cast<std::int64_t>(part.events.size());
      queue_.push_back({run, std::move(part)});
      lock.unlock();
      changed_.notify_all();
      return true;
    }
    if (when_full == WhenFull::kFail || Left()) {
      book.failure = away_ ? "The database has been away for too long: the recording ends here."
                           : "The disk is slower than the experiment: the recording has a hole.";
      return false;
    }
    changed_.wait_for(lock, kNextTry);
  }
  book.events += static_cast<std::int64_t>(part.events.size());
  return true;
}

/// Appends to the run's backlog.
bool Recorder::PutAside(const std::string& run, Book& book, const Part& part) {
  if (!MakeBacklog(run, book) || !book.backlog->Append(part).ok()) return false;
  if (!part.end) ++book.aside;
  return true;
}

bool Recorder::MakeBacklog(const std::string& run, Book& book) {
  if (book.backlog) return true;
  if (folder_.empty()) return false;
  auto opened = Backlog::Open(folder_, run);
  if (!opened) {
    log_("run " + run + ": " + opened.error().message);
    return false;
  }
  book.backlog.emplace(std::move(opened).value());
  if (book.end) (void)book.backlog->Append({.end = book.end});
  return true;
}

/// What is queued goes to the backlogs; what they do not take stays queued.
void Recorder::PutAllAside() {
  std::deque<Item> stay;
  for (Item& item : queue_) {
    Book& book = books_[item.run];
    const bool in_order = book.backlog || book.queued > 0;
    if (in_order && PutAside(item.run, book, item.part)) {
      --book.queued;
    } else {
      stay.push_back(std::move(item));
    }
  }
  queue_ = std::move(stay);
}

core::Status Recorder::Write(const std::string& run, const Part& part) {
  if (part.end) return core::Done{};  // the run stores it itself
  if (!part.samples.empty()) {
    TRY_DONE(room_ ? room_() : core::Done{});
    return store_.AppendChunk(run, part.samples.front().index, part.samples);
  }
  return store_.AppendEvents(run, part.events, part.events_before);
}

bool Recorder::Left() const {
  return stop_ || (leave_at_ && steady_clock::now() >= *leave_at_);
}

/// The next run in turn with something in its backlog.
std::map<std::string, Recorder::Book>::iterator Recorder::NextBehind() {
  const auto waits = [](const auto& each) { return each.second.aside > 0 && !each.second.refused; };
  const auto after = books_.upper_bound(behind_);
  const auto found = std::find_if(after, books_.end(), waits);
  if (found != books_.end()) return found;
  const auto again = std::find_if(books_.begin(), after, waits);
  return again == after ? books_.end() : again;
}

/// @returns false when there was nothing to write
bool Recorder::WriteNext(std::unique_lock<std::mutex>& lock) {
  const bool queued = !queue_.empty();
  const auto next = queued ? books_.find(queue_.front().run) : NextBehind();
  if (next == books_.end()) return false;
  const std::string run = next->first;
  const bool refused = next->second.refused;
  std::optional<Part> part = queued ? queue_.front().part : next->second.backlog->Front();
  lock.unlock();
  core::Status status = core::Done{};
  if (!part)
    status = core::Error{
        core::ErrorCode::kUnavailable, "its backlog is damaged", "", "recording_failed"};
  if (part && !refused) status = Write(run, *part);
  lock.lock();
  away_ = !status.ok() && MayPass(status.error());
  if (away_) {
    PutAllAside();
    return true;
  }
  Book& book = books_[run];
  if (!status.ok()) {
    book.refused = true;
    if (book.failure.empty()) book.failure = status.error().message;
  }
  if (queued) {
    queue_.pop_front();
    --book.queued;
  } else if (status.ok()) {
    behind_ = run;
    book.backlog->Pop();
    if (!part->end) --book.aside;
    if (book.aside == 0 && !book.end) {
      book.backlog->Remove();
      book.backlog.reset();
    }
  }
  return true;
}

void Recorder::StoreEnds(std::unique_lock<std::mutex>& lock) {
  const std::map<std::string, RunEnd> ends = ends_;
  for (const auto& [run, end] : ends) {
    lock.unlock();
    const core::Status stored = store_.Finish(run, end.state, end.at, "", "");
    lock.lock();
    const bool done = stored.ok() || stored.error().code == core::ErrorCode::kConflict ||
                      stored.error().code == core::ErrorCode::kNotFound;
    if (done) ends_.erase(run);
    if (!done) return;
  }
}

void Recorder::Loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto work = [this] { return stop_ || !queue_.empty() || NextBehind() != books_.end(); };
    if (away_) {
      changed_.wait_for(lock, kNextTry, [this] { return stop_; });
    } else if (!ends_.empty()) {
      changed_.wait_for(lock, kNextTry, work);
    } else {
      changed_.wait(lock, [&] { return work() || !ends_.empty(); });
    }
    if (stop_ && away_) break;
    const bool wrote = WriteNext(lock);
    if (!away_ && !wrote) StoreEnds(lock);
    if (!wrote && stop_) break;
    changed_.notify_all();
  }
  PutAllAside();
  for (const auto& [run, end] : ends_) (void)PutAside(run, books_[run], {.end = end});
}

core::Status Recorder::Drain(const std::string& run, const RunEnd& end) {
  std::unique_lock lock(mutex_);
  const auto found = books_.find(run);
  if (found == books_.end()) return core::Done{};
  Book& book = found->second;
  book.end = end;
  if (book.backlog) (void)book.backlog->Append({.end = end});
  const auto stored = [&] { return book.queued == 0 && (book.aside == 0 || book.refused); };
  while (!stored() && !Left()) {
    if (leave_at_) {
      changed_.wait_until(lock, *leave_at_);
    } else {
      changed_.wait(lock);
    }
  }
  if (!book.failure.empty()) {
    return core::Error{core::ErrorCode::kUnavailable, book.failure, {}, "recording_failed"};
  }
  if (!stored()) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "the database is away; the next start of the server stores the rest",
                       {},
                       std::string(kDatabaseAway)};
  }
  return core::Done{};
}

void Recorder::KeepEnd(const std::string& run, const RunEnd& end) {
  const std::lock_guard lock(mutex_);
  Book& book = books_[run];
  if (book.end && book.backlog) return;
  book.end = end;
  if (book.backlog) {
    (void)book.backlog->Append({.end = end});
  } else {
    (void)MakeBacklog(run, book);
  }
}

bool Recorder::WaitToTryAgain(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  auto until = steady_clock::now() + patience;
  if (leave_at_) until = std::min(until, *leave_at_);
  changed_.wait_until(lock, until, [&] { return leave_at_ && *leave_at_ < until; });
  return !Left();
}

void Recorder::Forget(const std::string& run) {
  const std::lock_guard lock(mutex_);
  const auto found = books_.find(run);
  if (found == books_.end()) return;
  Book& book = found->second;
  if (book.backlog && book.aside == 0) book.backlog->Remove();
  books_.erase(found);
}

void Recorder::EndLater(const std::string& run, const RunEnd& end) {
  {
    const std::lock_guard lock(mutex_);
    ends_[run] = end;
  }
  changed_.notify_all();
}

void Recorder::Leave(std::chrono::milliseconds patience) {
  {
    const std::lock_guard lock(mutex_);
    if (!leave_at_) leave_at_ = steady_clock::now() + patience;
  }
  changed_.notify_all();
}

}  // namespace faultlab::server
