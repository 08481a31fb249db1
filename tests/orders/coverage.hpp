#pragma once
// Coverage: which orders and faults met which states of the bench, and which faults met each other.
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "daemon/run/state.hpp"
#include "tests/orders/plan.hpp"

namespace shaker::orders {

class Coverage {
public:
    static constexpr std::size_t states = static_cast<std::size_t>(run::RunState::tripped) + 1;
    static constexpr double together_s = 0.5;  // two faults that begin within this time meet

    void action(run::RunState state, Action action);
    void fault(run::RunState state, std::size_t trouble, double at_s);
    void add(const Coverage& other);
    /// As numbers, for another process.
    [[nodiscard]] std::vector<std::uint64_t> numbers() const;
    /// Throws std::runtime_error for the numbers of a simulator with other states, actions or troubles.
    void add(const std::vector<std::uint64_t>& numbers);

    struct Pairs {
        std::string what;
        std::size_t all = 0, met = 0, ten_times = 0;  // of the possible pairs
        std::vector<std::string> rare{};              // met less than ten times, with the number
        std::vector<std::string> impossible{};        // met, although named as impossible
    };
    /// (state, order), (state, fault) and (fault, fault). Impossible are: all in state armed, which the run
    /// leaves in the step that enters it; and two kills, of which a plan has one.
    [[nodiscard]] std::vector<Pairs> pairs() const;
    /// Number of different (state, order, fault, fault), the faults within together_s before the order.
    [[nodiscard]] std::size_t fourfold() const noexcept { return fourfold_.size(); }

private:
    std::array<std::array<std::uint64_t, actions>, states> actions_{};
    std::array<std::array<std::uint64_t, troubles>, states> faults_{};
    std::array<std::array<std::uint64_t, troubles>, troubles> together_{};
    std::set<std::uint64_t> fourfold_{};
    std::vector<std::pair<double, std::size_t>> recent_{};  // faults, by time
};

}  // namespace shaker::orders
