# shellcheck shell=bash
# Shared by load.sh and targets.sh; sourced.

# crowd FOLDER TARGETS RADARS RATE_HZ ANTENNAS SECONDS: writes range.toml and scenario.toml of a flight of many targets, each tracked by every
# radar, with GPS of each once a second.
crowd() {
  local folder=$1 targets=$2 radars=$3 rate=$4 antennas=$5 seconds=$6 i
  {
    printf '[range]\nname = "crowd"\n'
    for ((i = 0; i < targets; i++)); do printf '[[target]]\nid = "t%04d"\n' "$i"; done
    for ((i = 0; i < radars; i++)); do
      printf '[[radar]]\nid = "radar-%d"\nlatitude_deg = %d.4\nlongitude_deg = %d.5\nheight_m = 100\nrate_hz = %s\n' \
        "$i" "$((33 + i % 2))" "$((126 + i))" "$rate"
      printf 'sigma_range_m = 25\nsigma_azimuth_deg = 0.01\nsigma_elevation_deg = 0.01\n'
    done
    printf '[[telemetry]]\nid = "tgs"\nlatitude_deg = 34.448\nlongitude_deg = 127.5165\nheight_m = 105\n'
    printf '[gps]\nsigma_horizontal_m = 5\nsigma_vertical_m = 8\nsigma_velocity_m_s = 0.2\n'
    for ((i = 0; i < antennas; i++)); do
      printf '[[antenna]]\nid = "antenna-%d"\ntarget = "t%04d"\nlatitude_deg = 34.4\nlongitude_deg = 127.%d\nheight_m = 100\n' \
        "$i" "$((i % targets))" "$((100 + i))"
      printf 'azimuth_min_deg = -360\nazimuth_max_deg = 360\nelevation_min_deg = -2\n'
      printf 'azimuth_rate_max_deg_s = 15\nelevation_rate_max_deg_s = 15\nlink_delay_ms = 5\nlead_ms = 50\n'
    done
    printf '[ingest]\nexpect_simulated = true\n'
  } >"$folder/range.toml"
  {
    printf 'name = "crowd"\ntarget = "t0000"\nliftoff_utc = 2026-03-01T08:00:00Z\nstart_s = 0\nend_s = %s\nseed = 1\n' "$seconds"
    printf '[trajectory]\nkind = "launch"\n[[phase]]\nname = "flight"\nfrom_s = 0\nto_s = %s\n' "$seconds"
    for ((i = 0; i < radars; i++)); do
      printf '[[radar]]\nid = "radar-%d"\nphase_ms = %d\nelevation_min_deg = -90\nlatency_ms = 40\nlatency_jitter_ms = 10\n' "$i" "$((7 + 9 * i))"
      printf '[radar.bias]\nrange_m = %d\nazimuth_deg = 0.02\nelevation_deg = -0.02\n' "$((10 * i - 20))"
    done
    printf '[gps]\nrate_hz = 1\nsigma_east_m = 5\nsigma_north_m = 5\nsigma_up_m = 8\nsigma_velocity_m_s = 0.2\n'
    printf 'latency_ms = 250\nsatellites = 10\n[[station]]\nid = "tgs"\nelevation_min_deg = -90\ndelay_ms = 100\n'
  } >"$folder/scenario.toml"
}
