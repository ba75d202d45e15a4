#pragma once
/// What logs and reports say of INTEGRITY: each change of a verdict, of the chain that is followed, and of the bound's
/// being there.

#include <downrange/stage/result.hpp>
#include <map>
#include <string>
#include <vector>

#include "stage/integrity_text.hpp"

namespace downrange {

class IntegrityNotes {
 public:
  /// One sentence for each change since the target's last record. The first record is compared with "all agree".
  [[nodiscard]] std::vector<std::string> changes(const Integrity& record) {
    std::vector<std::string> sentences;
    Told& told = told_[record.target];
    for (std::size_t i = 0; i < record.sources.size(); ++i) {
      const SourceIntegrity& source = record.sources[i];
      IntegrityVerdict& before = told.verdicts[source.sensor];
      if (before == source.verdict) continue;
      before = source.verdict;
      sentences.push_back(std::string(record.target.view()) + ": " + sentence(record, i));
    }
    const bool chain_changed = told.chain != record.chain || told.held_by != record.held_by;
    if (chain_changed || told.bounded != record.bound_valid) sentences.push_back(selection(record));
    told.chain = record.chain;
    told.held_by = record.held_by;
    told.bounded = record.bound_valid;
    return sentences;
  }

 private:
  struct Told {
    std::map<Name, IntegrityVerdict> verdicts;
    Name chain;
    Name held_by;
    bool bounded = false;
  };
  std::map<Name, Told> told_;
};

}  // namespace downrange
