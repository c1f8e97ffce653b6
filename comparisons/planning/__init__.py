"""No more than a scene needs: finds by measuring the least that keeps a picture within a tolerance, and proves it."""
