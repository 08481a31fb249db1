#pragma once
// Results of the tests so far, and the operator to whom they are shown.
#include <string>
#include <utility>
#include <vector>

#include "daemon/commissioning/commission.hpp"
#include "daemon/commissioning/session.hpp"
#include "drivers/commissioned/record.hpp"

namespace shaker::commissioning {

class Results {
public:
    /// person: outlives this object. before: results that the operator has seen.
    Results(const Operator& person, std::vector<commissioned::Item> before)
        : person_{person}, items_{std::move(before)} {}

    void add(const std::string& name, const std::string& result);
    /// Adds a stop by `what`. DeviceError when it took too long.
    void add_stop(const std::string& name, const std::string& what, const SeenStop& stop,
                  const std::string& more = {});
    /// Asks the operator and adds the confirmation. False, with the reason shown, when it is denied.
    bool agreed(const std::string& name, const std::string& question);
    void show(const std::string& text) const { person_.show(text); }
    [[nodiscard]] const std::vector<commissioned::Item>& items() const noexcept { return items_; }

private:
    const Operator& person_;
    std::vector<commissioned::Item> items_;
};

}  // namespace shaker::commissioning
