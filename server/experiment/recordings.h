#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"
#include "server/auth/accounts.h"
#include "server/auth/authorization.h"
#include "server/experiment/benches.h"
#include "server/experiment/long_turn.h"
#include "server/plots/figure.h"
#include "server/run/run_manager.h"
#include "server/storage/recording_store.h"
#include "server/story/run_story.h"

namespace faultlab::server {

/// A recording without gaps of meaning: what was measured, and by which options it is diagnosed.
struct Recording {
  RunRecord record;
  core::DiagnosisOptions options;
  std::vector<core::Sample> samples;
  LongTurn::Hold turn{};  ///< of a long one, as long as it is in memory
};

/// A recording with its diagnosis, and what happened meanwhile.
struct Review {
  Recording recording;
  core::Diagnosis diagnosis;
  std::vector<RecordedEvent> events;
  RunStory story;
};

enum class Missing { kLeftOut, kMade };

/// What runs and uploads have left behind, read by people and jobs. Every estimate, figure and
/// export of a recording uses the diagnosis options that are stored with it, and the diagnosis that
/// was made live; nothing is fitted a second time.
///
///   RecordingStore --record, samples--> Recordings --typed values--> api, jobs
///   RunManager ------a live verdict------^
///
/// Thread-safe; nothing is kept but the turn of long recordings.
class Recordings {
 public:
  /// All must outlive it.
  Recordings(RecordingStore& store,
             RunManager& runs,
             Accounts& accounts,
             Benches& benches,
             const Clock& clock,
             LongTurn::Short needs_no_turn,
             std::string member)
      : store_(store),
        runs_(runs),
        accounts_(accounts),
        benches_(benches),
        clock_(clock),
        long_turn_(needs_no_turn),
        member_(std::move(member)) {}

  /// Who answers a trial together with its run's owner reads this run like them.
  void ShareTrials(std::function<bool(std::int64_t trial, std::int64_t account)> is_of) {
    is_of_ = std::move(is_of);
  }

  /// What opens a sealed record, of a trial or a copy of one, that may be opened: asked before
  /// anybody is shown or refused anything for its seal.
  void OpenDueTrials(std::function<void(const RunRecord&)> open) { open_due_ = std::move(open); }
  /// What is asked about records that people bring, as long as blind trials are sealed.
  struct Watch {
    std::function<core::Status(const Principal&)> may_bring;
    /// The trials of whose sealed records this is, or contains, a copy.
    std::function<core::Result<std::vector<std::int64_t>>(std::span<const core::Sample>)> trials_of;
    /// A copy is about to be kept.
    std::function<core::Status(std::int64_t trial, const RunRecord& copy)> note;
  };
  void LetWatch(Watch watch) { watch_ = std::move(watch); }
  core::Status MayBring(const Principal& who) const {
    return watch_.may_bring ? watch_.may_bring(who) : core::Done{};
  }
  /// A sealed record as it is once what is due has been opened; any other as it is.
  core::Result<RunRecord> Opened(RunRecord record);

  /// The record, if `who` may do `operation` on it.
  core::Result<RunRecord> Find(const Principal& who, const std::string& id, Operation operation);

  /// Samples with index in [from, to). A long recording is refused while another person, or another
  /// job, has one in memory.
  core::Result<Recording> Load(RunRecord record,
                               std::int64_t from = 0,
                               std::int64_t to = kSampleIndexMax,
                               LongTurn::For whom = LongTurn::For::kPerson);
  /// For what several recordings, or a text, take together.
  LongTurn& long_turn() { return long_turn_; }
  core::Result<core::DiagnosisOptions> OptionsFor(const RunRecord& record);
  /// As they are now, for a run that goes on; of a sealed plan (SealedPlan) without those that tell
  /// its faults.
  core::Result<std::vector<RecordedEvent>> Events(const RunRecord& record);
  /// @param events   of it; of a sealed plan those that tell its faults are left out
  /// @param missing  a diagnosis that a crash has prevented
  RunStory StoryOf(const RunRecord& record, std::vector<RecordedEvent> events, Missing missing);
  /// As JSON: of a run that goes on, its verdict so far. A recording that was cut by a crash is
  /// diagnosed now, and keeps it.
  core::Result<std::string> DiagnosisText(const RunRecord& record);
  core::Result<Review> ReviewOf(RunRecord record);
  /// The same of one that needs no turn of its own.
  core::Result<Review> ReviewOf(RunRecord record, LongTurn::Hold turn);
  /// One of kFigureNames, in the words of MakeFigure. `footer` stands below it.
  core::Result<Figure> FigureOf(const RunRecord& record,
                                const std::string& name,
                                const std::string& footer);
  static core::Result<Figure> FigureOf(const Review& review,
                                       const std::string& name,
                                       const std::string& footer);
  /// Diagnoses and stores what somebody measured elsewhere. A copy of a sealed record is sealed
  /// like it, and diagnosed when that is opened.
  struct Upload {
    std::string name;
    std::string owner;
    core::DiagnosisOptions options;  ///< of its bench and its period
    std::vector<std::string> channels;
    std::vector<core::Sample> samples;
  };
  struct Kept {
    RunRecord record;
    core::Verdict verdict;
    std::vector<std::int64_t> copy_of{};  ///< trials whose sealed records it is, or contains
  };
  core::Result<Kept> Keep(Upload upload);
  /// What a recording of this bench that has ended learnt, or was judged by. Errors name the field
  /// "calibration".
  core::Result<core::Calibration> CalibrationOf(const Principal& who,
                                                const std::string& id,
                                                const core::Bench& bench);

 private:
  core::Result<Recording> LoadWith(RunRecord record,
                                   std::int64_t from,
                                   std::int64_t to,
                                   LongTurn::Hold turn);
  core::Result<Review> Reviewed(Recording recording);
  core::Result<core::Diagnosis> DiagnosisOf(const Recording& recording);
  core::Result<core::Diagnosis> Repair(const Recording& recording, std::string* text);

  RecordingStore& store_;
  RunManager& runs_;
  Accounts& accounts_;
  Benches& benches_;
  const Clock& clock_;
  std::function<bool(std::int64_t trial, std::int64_t account)> is_of_;
  std::function<void(const RunRecord&)> open_due_;
  Watch watch_;
  LongTurn long_turn_;
  const std::string member_;  ///< this server, which keeps the uploads it is sent
};

/// The recording, if `who` may read it and it has ended. Errors name `field`.
core::Result<RunRecord> FinishedRecording(Recordings& recordings,
                                          const Principal& who,
                                          const std::string& id,
                                          const std::string& field);
/// The options that are stored with the record of this bench; of a recording of an older program,
/// what that program used.
core::Result<core::DiagnosisOptions> OptionsOf(const RunRecord& record, const core::Bench& bench);

/// A record that learns nothing has no diagnosis: neither now nor when it is read again.
void LearnNothing(core::DiagnosisOptions& options);

/// What the rig's loop was like over the run, one JSON object: its last event carries it. "null"
/// before that.
std::string LoopText(std::span<const RecordedEvent> events);

}  // namespace faultlab::server
