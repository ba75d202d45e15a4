#pragma once
/// Reads the reference vectors that a range keeps beside the checkout (folder shared/, or $DOWNRANGE_SHARED).

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <source_dir.hpp>
#include <string>

namespace downrange::test {

inline std::filesystem::path shared_folder() {
  if (const char* given = std::getenv("DOWNRANGE_SHARED")) return given;
  return std::filesystem::path(DOWNRANGE_SOURCE_DIR) / ".." / "shared";
}

/// The cases of one vector file; an empty array when the folder is absent (the caller skips).
inline nlohmann::json vector_cases(const std::string& file) {
  std::ifstream in(shared_folder() / "vectors" / file);
  if (!in) return nlohmann::json::array();
  return nlohmann::json::parse(in).at("cases");
}

inline Eigen::VectorXd vector_of(const nlohmann::json& j) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(j.size()));
  for (std::size_t i = 0; i < j.size(); ++i) v[static_cast<Eigen::Index>(i)] = j[i].get<double>();
  return v;
}

inline Eigen::MatrixXd matrix_of(const nlohmann::json& j) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(j.size()), static_cast<Eigen::Index>(j[0].size()));
  for (std::size_t i = 0; i < j.size(); ++i) m.row(static_cast<Eigen::Index>(i)) = vector_of(j[i]).transpose();
  return m;
}

/// Largest difference relative to the size of `expected` (its largest entry).
inline double relative_error(const Eigen::MatrixXd& actual, const Eigen::MatrixXd& expected) {
  return (actual - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

}  // namespace downrange::test

#define DOWNRANGE_VECTOR_CASES(name, file)                 \
  const auto name = ::downrange::test::vector_cases(file); \
  if (name.empty()) GTEST_SKIP() << "no reference vectors here: " << ::downrange::test::shared_folder()
