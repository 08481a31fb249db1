#include "tests/orders/scpi_answers.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iterator>
#include <regex>

namespace shaker::orders {

namespace {

const std::string number = R"([-+]?[0-9]+(\.[0-9]+)?(E[-+]?[0-9]+)?)";
const std::string boolean = R"(0|1|9\.91[0E+]*37)";  // NaN before the first state
const std::string word = R"("[^"]*")";
const std::string drift = number + "," + number + "," + number + ",[0-9]+,[01]";

}  // namespace

const std::vector<Query>& plain_queries() {
    static const std::vector<Query> all{
        {"OUTP?", boolean},   {"OUTP:PROT:TRIP?", boolean}, {"OUTP:PROT:CAUS?", word},
        {"SYST:STAT?", word}, {"LIM:DRIV:ABOR?", number},   {"ACC?", number},
        {"*OPC?", "1"},       {"*STB?", "[0-9]+"},          {"SYST:ERR?", R"([-+]?[0-9]+,".*")"}};
    return all;
}

std::string form_of(const std::string& message) {
    static const std::vector<Query> others{
        {"READ?", drift}, {"FETC:DRIF?", drift}, {"ABOR?", "0|1"}, {"SYST:LOCK:REQ?", "0|1"}};
    for (const std::vector<Query>* queries : {&plain_queries(), &others})
        for (const Query& q : *queries)
            if (message == q.text + '\n') return q.form;
    return {};
}

void ScpiAnswers::asked(const std::string& form, bool withheld) { owed_.push_back({form, withheld, false}); }

void ScpiAnswers::dropped() {
    if (owed_.empty()) return;
    owed_.front().optional = owed_.front().withheld;
    const auto behind = std::next(owed_.begin());
    owed_.erase(std::remove_if(behind, owed_.end(), [](const Owed& o) { return o.withheld; }), owed_.end());
}

void ScpiAnswers::nothing_withheld() {
    std::erase_if(owed_, [](const Owed& o) { return o.optional; });
    for (Owed& o : owed_) o.withheld = false;
}

std::string ScpiAnswers::take(const std::string& line) {
    while (!owed_.empty()) {
        const Owed first = owed_.front();
        owed_.pop_front();
        if (std::regex_match(line, std::regex{first.form})) return {};
        if (!first.optional) return fmt::format("'{}' has not the form {}", line, first.form);
    }
    return fmt::format("'{}' answers no query", line);
}

std::string ScpiAnswers::due() const { return owed_.empty() ? "" : owed_.front().form; }

}  // namespace shaker::orders
