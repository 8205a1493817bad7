// Where the fixtures and the air of a rig are at a moment of a show.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fixtures/media/media_player.h"
#include "fixtures/simulate/machines.h"

namespace footlight::render {

struct FrameState {
  // The newest levels, and what the GPU knows of heads: 48 bytes a head, and 24 to 116 for each part that moves.
  std::vector<std::byte> heads;
  fixtures::MachineAir::Air air;
  std::vector<fixtures::MediaPlayer::State> media;
  std::int64_t time_ns = 0;  // of all steps so far: clouds of haze drift by it
  // universes x 512 bytes, for what the host draws of them: pixel maps of projectors, dimmers of screens.
  std::vector<std::uint8_t> newest;
  [[nodiscard]] std::size_t bytes() const {
    return heads.size() + newest.size() + air.plumes.size() * sizeof(fixtures::Plume) +
           media.size() * sizeof(fixtures::MediaPlayer::State) + sizeof(*this);
  }
};

}  // namespace footlight::render
