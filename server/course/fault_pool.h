#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/isolability/isolability_options.h"
#include "core/types/fault.h"
#include "core/types/plant_parameters.h"
#include "core/types/result.h"

namespace faultlab::server::course {

/// One kind of fault that a blind trial may have.
struct PoolItem {
  core::Component component{};
  std::vector<double> values;  ///< SI; empty: any in [low, high], equally likely by its logarithm
  double low = 0.0;            ///< SI
  double high = 0.0;
  core::FaultKind kind = core::FaultKind::kAbrupt;
  double onset_from_s = 0.0;  ///< at_s lies in [onset_from_s, onset_to_s]
  double onset_to_s = 0.0;
  double lasts_s = 0.0;  ///< of a drift or an intermittent fault
  double weight = 1.0;   ///< how often, relative to the other items
};

/// What the faults of blind trials are drawn from.
struct FaultPool {
  std::vector<PoolItem> items;  ///< 1 .. kItemsMax
  double healthy_share = 0.2;   ///< of the trials, [0, 0.9]
};
inline constexpr std::size_t kItemsMax = 64;

/// {"items": [{"component", "values" | "low" and "high", "kind", "onset_from_s", "onset_to_s",
/// "lasts_s", "weight"}], "healthy_share"}. Errors carry a JSON pointer below `pointer`. A fault
/// begins after the stretch in which the bench learns its healthy rig.
core::Result<FaultPool> ParsePool(const boost::json::object& body, const core::Bench& bench);
/// The same of a stored document.
core::Result<FaultPool> ParsePool(std::string_view document, const core::Bench& bench);
boost::json::object ToJson(const FaultPool& pool);

/// A fault of each item that stands for it: of a range the geometric mean, of a list its middle
/// value; it begins in the middle of its window.
std::vector<core::Fault> Representatives(const FaultPool& pool);
/// Of each item the values nearest to nominal on either side, by their logarithm: what can be seen
/// of them, can be seen of all.
std::vector<core::Fault> HardestToSee(const FaultPool& pool, const core::PlantParameters& nominal);
/// What a trial may have, and how often.
struct LikelyDraw {
  std::optional<core::FaultSize> fault;  ///< none: a healthy rig
  double share = 0.0;                    ///< of the trials; they sum to 1
};
/// The healthy rig where there are some, then of each item its values; of a range three that stand
/// for it.
std::vector<LikelyDraw> LikelyDraws(const FaultPool& pool);
/// When the last of its faults is over; a run must be longer.
double LastsUntil(const FaultPool& pool);

/// The faults of one trial: none, or one. A function of its arguments to the bit.
/// @param drawn  items of this person's former trials, by their place in the pool, -1 of a healthy
///    one: what they have had comes again only when they have had the whole pool
/// @param item   the item that was drawn, -1: healthy
std::vector<core::Fault> Draw(const FaultPool& pool,
                              const std::vector<int>& drawn,
                              std::uint64_t seed,
                              int* item);

}  // namespace faultlab::server::course
