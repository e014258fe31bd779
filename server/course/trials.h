#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/course/assignments.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::course {

enum class TrialState {
  kDrawn,     ///< the truth is drawn, the run has not begun
  kRunning,   ///< its run goes on
  kOpen,      ///< the run has ended; an answer is awaited
  kAnswered,  ///< answered and graded
  kVoid,      ///< something went wrong that is not the student's: the attempt is returned
};
/// "drawn", "running", "open", "answered", "void"
std::string_view Name(TrialState state);

/// One attempt of one student. `truth`, `nonce`, `events` and `grade` leave the server when
/// `released` is set, and not before.
struct Trial {
  std::int64_t id = 0;
  std::int64_t assignment = 0;
  std::int64_t account = 0;
  TrialState state = TrialState::kDrawn;
  int item = -1;           ///< of the pool; -1: healthy
  std::string run;         ///< empty until it has begun
  std::string commitment;  ///< Commitment::hash
  std::string nonce;
  std::string truth;   ///< {"faults": [..], "seed": N}
  std::string events;  ///< EventsText: what the rig confirmed; once answered, what the lab saw too
  WallTime created_at{};
  std::optional<WallTime> ended_at;
  std::string answer;  ///< Answer as JSON; empty: none yet
  std::optional<WallTime> answered_at;
  std::string grade;           ///< Grade as JSON
  std::int64_t graded_by = 1;  ///< Assignment::rubric_version
  std::string awarded;  ///< {"points", "reason", "by"} by a teacher, in place of it; empty: none
  std::optional<WallTime> released_at;
  std::string why;  ///< of a void one: a word of the contract
  /// Who brought its record for a diagnosis while it was sealed:
  /// [{"account": N or null, "recording", "at_ms"}]
  std::string copies = "[]";
  std::string hints = "[]";  ///< HintOf, as they were taken, each with its price
  bool tried = false;        ///< a teacher tried the exercise: it counts nowhere
};

/// Thread-safe, stateless. A transition from another state than the one it needs is kConflict.
class Trials {
 public:
  explicit Trials(Database& database) : database_(database) {}

  /// A new trial in the state kDrawn. `draw` fills item, truth, nonce and commitment, and knows the
  /// person's former ones, void ones included. kConflict "trial_open" while one is not answered and
  /// can be, "attempts_used" when as many as `attempts` count.
  /// @param limit  so long after its begin a trial can be answered
  core::Result<Trial> Add(std::int64_t assignment,
                          std::int64_t account,
                          int attempts,
                          WallTime now,
                          std::optional<std::chrono::milliseconds> limit,
                          const std::function<void(const std::vector<Trial>&, Trial&)>& draw);
  /// Of one whose run could not begin: as if it had not been drawn.
  core::Status Forget(std::int64_t id);
  core::Status Began(std::int64_t id, const std::string& run);
  core::Status Ended(std::int64_t id, const std::string& events, WallTime now);
  /// @param hints  as they were when it was graded; kConflict "trial_changed" when they are others
  core::Status Answer(std::int64_t id,
                      const std::string& hints,
                      const std::string& answer,
                      const std::string& grade,
                      std::int64_t graded_by,
                      const std::string& events,
                      WallTime now);
  /// Of one that is open: in place of `had`, or kConflict "trial_changed".
  core::Status TakeHint(std::int64_t id, const std::string& had, const std::string& hints);
  /// By a rubric that is newer than that of the grade it has; otherwise nothing changes.
  core::Status GradeAgain(std::int64_t id, const std::string& grade, std::int64_t graded_by);
  core::Status Release(std::int64_t id, WallTime now);
  /// A teacher's points for one that is released; empty: the grade counts again.
  core::Status Award(std::int64_t id, const std::string& awarded);
  /// Of one that is not answered.
  core::Status Void(std::int64_t id, const std::string& why, WallTime now);

  core::Result<Trial> Get(std::int64_t id);

  /// A trial with a run that may still be kept from people.
  struct Sealed {
    std::int64_t id = 0;
    std::string run;
    std::int64_t assignment = 0;
    std::int64_t account = 0;
  };
  /// All that are not released, of assignments that may still be open.
  core::Result<std::vector<Sealed>> SealedNow(WallTime now);
  /// Appends an object to Trial::copies, at most kCopiesMax of them: the first ones stay.
  static constexpr std::size_t kCopiesMax = 100;
  core::Status AddCopy(std::int64_t id, const std::string& copy_json);
  /// Whether this person, or somebody in the same group, has begun it.
  core::Result<bool> IsOf(std::int64_t id, std::int64_t account);
  /// Of all persons, or of one and their group; in order of id.
  core::Result<std::vector<Trial>> Of(std::int64_t assignment,
                                      std::optional<std::int64_t> account,
                                      std::int64_t after,
                                      int limit);

  /// Answered ones that are due and not released, or graded by an older rubric; in order of id.
  core::Result<std::vector<std::int64_t>> Overdue(std::int64_t after,
                                                  std::size_t limit,
                                                  WallTime now);
  /// How many are graded by an older rubric.
  core::Result<std::int64_t> Stale(const Assignment& assignment);

  /// Who has begun a trial that counts, and whether they have answered one.
  core::Result<std::map<std::int64_t, bool>> Begun(std::int64_t assignment);

 private:
  Database& database_;
};

}  // namespace faultlab::server::course
