#pragma once
// Plans in processes of their own: the memory of one does not count for another, and a crash ends only one.
#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "tests/orders/simulation.hpp"

namespace shaker::orders {

/// simulate() in a process of its own, with two more laws: its memory is bounded (without sanitisers, which
/// keep freed memory), and it ends by itself. Removes the folder.
Outcome play_alone(const Plan& plan, const std::filesystem::path& folder);

struct Shortest {
    Plan plan;
    Outcome outcome;
};
/// The shortest plan found that still breaks the first law of `outcome`: without the moves and faults that it
/// does not need, and with an early end. Plays plans below `folder`.
Shortest shortest(const Plan& plan, const Outcome& outcome, const std::filesystem::path& folder);

/// For another process, and for files.
nlohmann::json as_json(const Outcome& outcome);
Outcome outcome_of(const nlohmann::json& json);

}  // namespace shaker::orders
