# A release pins this by digest:  --build-arg BASE=python:3.11-slim@sha256:...
ARG BASE=python:3.11-slim

FROM ${BASE} AS build
COPY requirements/serve.txt scripts/trim.py /tmp/
# pip serves the build alone: it installs from outside the environment and never enters it. Wheels alone, so that nothing
# runs at install and no compiler is needed.
RUN python -m venv --without-pip /venv \
    && python -m pip --python /venv/bin/python install --no-cache-dir --no-compile --disable-pip-version-check \
        --require-hashes --only-binary :all: -r /tmp/serve.txt \
    && python /tmp/trim.py /venv/lib/python3.*/site-packages
WORKDIR /gainscope
COPY . .
# Layers keep whole seconds: a file must not look changed, to a cache that goes by its time, once it is in one.
RUN find . -type f -exec sh -c 'for file; do touch -d "@$(stat -c %Y "$file")" "$file"; done' sh {} +
# The server cannot write bytecode later. None of it is compared with its source, which nobody can change.
RUN /venv/bin/python -m compileall -q -j 0 --invalidation-mode unchecked-hash /venv/lib .
# Made once, after the times of files have been set: machine code for the family of processors that servers have (on any
# other the server compiles at its start), and everything that browsers keep, compressed as small as it goes.
RUN { [ "$(uname -m)" != x86_64 ] || /venv/bin/python -m tracker_core compile --level x86-64-v3; } \
    && /venv/bin/python -m scripts.compress \
    && chmod -R a+rX /gainscope


FROM ${BASE}
# No compiler was in it; what installs packages or gives away rights goes too.
RUN find / -xdev -depth \( -path '*/bin/pip*' -o -path '*/ensurepip' -o -path '*/site-packages/*' -o -path '*/dist-packages/*' \) \
        -exec rm -r {} + \
    && find / -xdev -type f -perm /6000 -exec chmod a-s {} +
# Fixed, so that what is mounted can be given to it; no home, no shell. What is mounted as /data must belong to it, as a
# new volume does.
RUN groupadd --gid 10001 gainscope \
    && useradd --uid 10001 --gid gainscope --no-create-home --home-dir /nonexistent --shell /usr/sbin/nologin gainscope \
    && install --directory --mode=0700 --owner=10001 --group=10001 /data
COPY --from=build /venv /venv
COPY --from=build /gainscope /gainscope
WORKDIR /gainscope
USER 10001:10001

# A root file system that is read only has no room but /tmp.
ENV PATH=/venv/bin:$PATH \
    PYTHONDONTWRITEBYTECODE=1 \
    PYTHONUNBUFFERED=1 \
    NUMBA_CACHE_DIR=/tmp/numba \
    OPENBLAS_NUM_THREADS=1 \
    GAINSCOPE_HOST=0.0.0.0 \
    GAINSCOPE_PORT=8050 \
    GAINSCOPE_DATA=/data
VOLUME /data
EXPOSE 8050

HEALTHCHECK --interval=15s --timeout=5s --start-period=60s --retries=3 CMD ["python", "scripts/healthcheck.py"]
CMD ["python", "app.py"]

# Last: another version or revision takes nothing else anew.
ARG VERSION=0.1.0
ARG REVISION=unknown
ARG BASE
LABEL org.opencontainers.image.title="Gainscope" \
      org.opencontainers.image.description="An interactive laboratory for alpha-beta(-gamma(-eta)) tracking filters" \
      org.opencontainers.image.version="${VERSION}" \
      org.opencontainers.image.revision="${REVISION}" \
      org.opencontainers.image.base.name="${BASE}"
