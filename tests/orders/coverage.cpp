#include "tests/orders/coverage.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <stdexcept>

namespace shaker::orders {

namespace {

void count(Coverage::Pairs& pairs, bool possible, std::uint64_t times, const std::string& name) {
    if (!possible) {
        if (times > 0) pairs.impossible.push_back(name);
        return;
    }
    ++pairs.all;
    pairs.met += times > 0 ? 1 : 0;
    pairs.ten_times += times >= 10 ? 1 : 0;
    if (times < 10) pairs.rare.push_back(fmt::format("{} ({})", name, times));
}

bool possible(std::size_t state) { return static_cast<run::RunState>(state) != run::RunState::armed; }
bool possible(std::size_t first, std::size_t second) {
    constexpr auto killed = static_cast<std::size_t>(Trouble::killed);
    return first != killed || second != killed;
}

// In lockstep a recording is finished within a step, so `finishing` belongs to idle.
std::size_t place_of(run::RunState state) {
    return static_cast<std::size_t>(state == run::RunState::finishing ? run::RunState::idle : state);
}

}  // namespace

void Coverage::action(run::RunState state, Action action) {
    const auto s = place_of(state), a = static_cast<std::size_t>(action);
    ++actions_.at(s).at(a);
    for (const auto& [first_s, first] : recent_)
        for (const auto& [second_s, second] : recent_)
            if (first <= second) fourfold_.insert(((s * actions + a) * troubles + first) * troubles + second);
}

void Coverage::fault(run::RunState state, std::size_t trouble, double at_s) {
    ++faults_.at(place_of(state)).at(trouble);
    std::erase_if(recent_, [&](const auto& f) { return f.first < at_s - together_s || f.first > at_s; });
    for (const auto& [other_s, other] : recent_)
        ++together_.at(std::min(other, trouble)).at(std::max(other, trouble));
    recent_.emplace_back(at_s, trouble);
}

void Coverage::add(const Coverage& other) { add(other.numbers()); }

std::vector<std::uint64_t> Coverage::numbers() const {
    std::vector<std::uint64_t> all{states, actions, troubles};
    const auto append = [&](const auto& table) {
        for (const auto& row : table) all.insert(all.end(), row.begin(), row.end());
    };
    append(actions_);
    append(faults_);
    append(together_);
    all.insert(all.end(), fourfold_.begin(), fourfold_.end());
    return all;
}

void Coverage::add(const std::vector<std::uint64_t>& numbers) {
    constexpr std::array<std::uint64_t, 3> head{states, actions, troubles};
    if (numbers.size() < head.size() + states * (actions + troubles) + troubles * troubles ||
        !std::equal(head.begin(), head.end(), numbers.begin()))
        throw std::runtime_error{
            "an outcome of another version of the simulator; go on with a new file (--done)"};
    auto next = numbers.begin() + head.size();
    const auto take = [&](auto& table) {
        for (auto& row : table)
            for (std::uint64_t& count : row) count += *next++;
    };
    take(actions_);
    take(faults_);
    take(together_);
    fourfold_.insert(next, numbers.end());
}

std::vector<Coverage::Pairs> Coverage::pairs() const {
    std::vector<Pairs> all{{"state, order"}, {"state, fault"}, {"fault, fault"}};
    for (std::size_t s = 0; s < states; ++s) {
        const char* state = name(static_cast<run::RunState>(s));
        for (std::size_t a = 0; a < actions; ++a)
            count(all[0], possible(s), actions_[s][a], fmt::format("{} in {}", action_names.at(a), state));
        for (std::size_t t = 0; t < troubles; ++t)
            count(all[1], possible(s), faults_[s][t], fmt::format("{} in {}", name_of_trouble(t), state));
    }
    for (std::size_t a = 0; a < troubles; ++a)
        for (std::size_t b = a; b < troubles; ++b)
            count(all[2], possible(a, b), together_[a][b],
                  fmt::format("{} with {}", name_of_trouble(a), name_of_trouble(b)));
    return all;
}

}  // namespace shaker::orders
