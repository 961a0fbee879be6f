// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/metashape_file.h"
#include "tests/fuzz/fuzz_files.h"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace relight;
  const auto& folder = fuzz::Written(data, size, {"cameras.xml"});
  return fuzz::Survives(
      [&] { return ReadMetashape(folder / "cameras.xml", fuzz::Photos()); });
}
