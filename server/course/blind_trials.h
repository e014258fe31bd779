#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnosis/diagnosis.h"
#include "core/types/result.h"
#include "server/auth/principal.h"
#include "server/clock.h"
#include "server/course/answer.h"
#include "server/course/assignments.h"
#include "server/course/fault_pool.h"
#include "server/course/grade.h"
#include "server/course/trials.h"
#include "server/experiment/benches.h"
#include "server/experiment/experiments.h"
#include "server/experiment/recordings.h"
#include "server/storage/recording_store.h"

namespace faultlab::server::course {

/// Blind trials from their draw to their release.
///
///   Assignment --Draw--> truth, commitment --sealed plan--> Experiments --run--> the student
///                          |                                   | SealedWitness: what relays
///                          confirmed v                                   v
///                        Trials <----------- drawn = confirmed, or void
///   Answer --recording, DiagnoseRecord, GradeAnswer--> Trials --released--> plan, events,
///   diagnosis
///                                                                           of the run are opened
///
/// Nothing of the truth is where a student's request could read it: the run itself lacks it until
/// it is released. Thread-safe.
class BlindTrials {
 public:
  struct Parts {
    Assignments& assignments;
    Trials& trials;
    Experiments& experiments;
    Recordings& recordings;
    RecordingStore& store;
    Benches& benches;
    std::function<bool(lab::SessionId)> ended_by_user;  ///< of MakeWitness
    const Clock& clock;
    /// Wall time that no step of the clock has moved just now: a release cannot be taken back.
    std::function<core::Result<WallTime>()> settled;
    std::function<void(std::string_view)> log;
  };
  /// All parts must outlive it; the clock also every run that it has begun.
  explicit BlindTrials(Parts parts) : parts_(parts) {}

  /// From when on no trial of this person begins and no answer is taken: when it was due, and what
  /// the rubric allows beyond.
  static WallTime ClosesFor(const Assignment& assignment, std::int64_t account);
  /// Until when this trial can be answered: then, or when its time is over.
  static WallTime AnswerBy(const Assignment& assignment, const Trial& trial);

  /// Draws a trial and begins its run: on a simulator, or on `rig`, on which the person has a
  /// session, where the assignment is for benches. kConflict: "assignment_closed",
  /// "assignment_not_open", those of Trials::Add, and those of Experiments::Start, after which the
  /// attempt is there again.
  /// @param excitation  of a plan, as the student wants it; null: that of the assignment.
  ///    kConflict "excitation_fixed" where all play the same
  /// @param tries  a teacher tries the exercise, also before it opens
  core::Result<Trial> Start(const Principal& who,
                            const Assignment& assignment,
                            const std::string& rig,
                            const boost::json::object* excitation,
                            bool tries);
  /// As it is now: one whose server died is void, one that is closed is released, and one whose
  /// rubric has changed is graded again.
  core::Result<Trial> Look(const Assignment& assignment, Trial trial);
  /// The same of any trial, for who only wants it done.
  core::Status Look(std::int64_t trial);
  /// The same for its sealed record, or a copy of it, which is opened when all trials whose records
  /// it contains are released, or no longer exist.
  core::Status Open(const RunRecord& record);
  /// After such a look; false of one that no longer exists.
  core::Result<bool> IsSealedNow(std::int64_t trial);
  /// Grades and keeps the first answer. kConflict "answer_late" after it was closed,
  /// "trial_changed" when there is one already, "trial_runs" before the end of the run.
  core::Result<Trial> TakeAnswer(const Assignment& assignment,
                                 const Trial& trial,
                                 const Answer& answer);
  /// The lab's hint with this number, from 1, if the trial does not have it yet and the rubric has
  /// hints. Refuses as TakeAnswer does.
  core::Result<Trial> TakeHint(const Assignment& assignment,
                               const Trial& trial,
                               std::int64_t number);

 private:
  /// Its record, if it can be answered now.
  core::Result<RunRecord> Answerable(const Assignment& assignment, const Trial& trial);
  /// Once it is their turn.
  core::Result<Trial> Begin(const Principal& who,
                            const Assignment& assignment,
                            const FaultPool& pool,
                            ExperimentPlan plan,
                            bool tries);
  /// The lab's own diagnosis of a run that was sealed, and its events.
  struct Seen {
    core::Diagnosis diagnosis;
    std::vector<RecordedEvent> events;
  };
  core::Result<Seen> See(RunRecord record);
  core::Result<Grade> GradeOf(const Assignment& assignment,
                              const Trial& trial,
                              const Answer& answer,
                              const core::Diagnosis& diagnosis,
                              double length_s);
  core::Status GradeAgain(const Assignment& assignment, const Trial& trial);
  core::Status Release(const Assignment& assignment, const Trial& trial);
  core::Result<const core::Bench*> BenchOf(const Assignment& assignment);

  Parts parts_;
};

}  // namespace faultlab::server::course
