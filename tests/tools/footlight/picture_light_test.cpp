// Memory of the light of pictures: used again, also when another thread lets go of it. Needs no libav.
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "tests/tools/footlight/clip_files.h"
#include "tools/footlight/displays/picture_light.h"

namespace footlight::tools {
namespace {

using drivers::Picture;
using fixtures::PaneImage;

TEST_CASE("the light of a picture is the same in memory that is used again, and stays while it is held") {
  const LightCurve256 curve = light_curve(0);
  const Picture first = picture_of(1, 160, 90), second = picture_of(2, 160, 90);
  for (const auto& [columns, rows] : {std::pair{160, 90}, {48, 27}}) {
    CAPTURE(columns);
    const PaneImage one = light_of(first, curve, columns, rows), two = light_of(second, curve, columns, rows);
    std::shared_ptr<const PaneImage> held, let_go;
    {
      LightImages images;
      held = images.light_of(first, curve, columns, rows);
      let_go = images.light_of(first, curve, columns, rows);
      const glm::vec3* const memory = let_go->texels.data();
      CHECK(held->texels.data() != memory);
      let_go.reset();
      let_go = images.light_of(second, curve, columns, rows);
      CHECK(let_go->texels.data() == memory);
    }
    CHECK(held->texels == one.texels);
    CHECK(let_go->texels == two.texels);
  }
}

TEST_CASE("images that another thread lets go of while new ones are made have the light of their pictures") {
  const LightCurve256 curve = light_curve(0);
  constexpr int kPictures = 4, kImages = 400;
  std::vector<Picture> pictures;
  std::vector<PaneImage> fresh;
  for (int i = 0; i < kPictures; ++i) {
    pictures.push_back(picture_of(i, 64, 36));
    fresh.push_back(light_of(pictures.back(), curve, 64, 36));
  }
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::shared_ptr<const PaneImage>> given;
  // It holds at most three images, compares the oldest one, and lets go of it without the lock.
  int wrong = 0;
  std::thread holder([&] {
    for (int i = 0; i < kImages; ++i) {
      std::shared_ptr<const PaneImage> image;
      {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return !given.empty(); });
        image = std::move(given.front());
        given.pop_front();
      }
      changed.notify_one();
      if (image->texels != fresh[static_cast<std::size_t>(i % kPictures)].texels) ++wrong;
    }
  });
  {
    LightImages images;
    for (int i = 0; i < kImages; ++i) {
      auto image = images.light_of(pictures[static_cast<std::size_t>(i % kPictures)], curve, 64, 36);
      std::unique_lock lock(mutex);
      changed.wait(lock, [&] { return given.size() < 3; });
      given.push_back(std::move(image));
      changed.notify_one();
    }
  }
  holder.join();
  CHECK(wrong == 0);
}

}  // namespace
}  // namespace footlight::tools
