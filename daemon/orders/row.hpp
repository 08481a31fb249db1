#pragma once
// The orders of a bench on call as one table. HTTP, shakerctl, SCPI, the page and Python are made from it.
#include <cstddef>
#include <span>
#include <string_view>

#include "drivers/quantity.hpp"

namespace shaker::orders {

enum class Kind {
    quantity,  // a number in SI units, or a text with a unit
    whole,     // a whole number
    word,      // one of `words`
    flag,      // true or false; on or off in a shell and in SCPI
    text,
    free,     // a quantity; another field decides its dimension
    regions,  // regions of targets; each door reads them itself
};

/// One value of an order. `allowed` is in SI units, with both ends.
struct Field {
    std::string_view key;       // in JSON
    std::string_view option{};  // of shakerctl: "--gamma", or "MU" for a word without dashes; empty: none
    std::string_view value{};   // its name in the help of shakerctl
    std::string_view help{};    // one line without its full stop
    Kind kind = Kind::text;
    Dimension dimension = Dimension::ratio;
    Range allowed{};
    std::span<const std::string_view> words{};
    std::string_view otherwise{};  // what holds without it, for the help
    bool needed = false;
    bool scpi = true;  // a parameter of the SCPI command, in this order
};

/// In which situation an order is accepted, and what it may do.
struct When {
    bool at_rest = true, driven = true, tripped = true;  // without a campaign; a trip is not yet cleared
    /// What a campaign under way or in preparation does not allow, for the refusal; empty: it is accepted.
    std::string_view not_in_campaign{};
    bool starts = false;          // it begins a drive: a stop that comes after it voids it
    bool may_drive = false;       // refused by a program that ends
    bool outlasts_abort = false;  // carried out although an abort came after it: nothing can be driven by it
    bool overtakes = false;       // does not wait behind an order that waits for the disk
};

/// To add an order: a row here, its struct in service/bench_port.hpp, how values become it in
/// service/made_order.cpp, what it does in service/bench_orders.cpp.
struct Row {
    std::string_view name;       // POST /api/NAME
    std::string_view summary;    // for the help: a sentence without its full stop
    std::string_view details{};  // further sentences
    std::string_view example{};  // a command line
    std::span<const Field> fields{};
    std::string_view scpi{};  // header of the SCPI command; empty: several commands give it
    When when{};
    std::string_view log{};  // for the log, where its values do not matter
};

/// All orders that a client may give, but for the abort, which no table, lock or parser may delay.
std::span<const Row> rows();
/// The row with this name; null when no row has it.
const Row* find(std::string_view name);
/// The row with this name, which must exist.
const Row& row(std::string_view name);

}  // namespace shaker::orders
